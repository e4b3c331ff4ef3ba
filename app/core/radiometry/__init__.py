"""From the numbers of an instrument to reflectance: one file per effect, chained.

A step says what one part of the instrument does to light (forward, `respond`) and how to
take it back (`invert`). A channel is calibrated by a chain of steps, from light to number.
"""
