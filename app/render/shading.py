"""Colours on the graphics card: value → table → colour, and marks over it.

Each point carries its value and the code of its mark as vertex attributes; the colour table is
a texture of 256 × 1, the limits are uniforms. A new range or colour map costs a redraw, a new
field the upload of one number per point, and points are never touched.
"""

from __future__ import annotations

import numpy as np
from vtkmodules.util.numpy_support import numpy_to_vtk
from vtkmodules.vtkCommonDataModel import vtkDataObject, vtkImageData
from vtkmodules.vtkRenderingCore import vtkProperty, vtkShaderProperty, vtkTexture
from vtkmodules.vtkRenderingOpenGL2 import vtkOpenGLPolyDataMapper, vtkOpenGLShaderProperty

from app.core.arrays import AnyArray
from app.render.palettes import Bytes, Rgb

VALUE, MARK = "fieldValue", "markCode"
# Drivers may assume that NaN cannot occur, so it is drawn by an impossible number.
NO_VALUE = np.float32(-3.0e38)

VERTEX_DEC = """//VTK::ValuePass::Dec
in float fieldValue;
in float markCode;
out float valueOut;
out float markOut;
out float depthOut;
"""
# In perspective w is the distance along the view; in an orthographic view z is linear itself.
VERTEX_IMPL = """//VTK::ValuePass::Impl
  valueOut = fieldValue;
  markOut = markCode;
  depthOut = nearest < 0.0
    ? 0.5 * gl_Position.z + 0.5
    : (gl_Position.w - nearest) / (farthest - nearest);
"""
FRAGMENT_DEC = """//VTK::ValuePass::Dec
in float valueOut;
in float markOut;
in float depthOut;
"""
# `table_rows` in palettes.py holds the same formula.
FRAGMENT_COLOUR = """//VTK::Color::Impl
  float row = categorical > 0.5
    ? mod(floor(valueOut + 0.5), 256.0)
    : floor(clamp((valueOut - low) / max(high - low, 1.0e-30), 0.0, 1.0) * 255.0 + 0.5);
  vec3 shown = valueOut < -1.0e38
    ? mix(missing, haze, hazeStrength * clamp(depthOut, 0.0, 1.0))
    : texture(palette, vec2((row + 0.5) / 256.0, 0.5)).rgb;
  vec4 mark = texture(marks, vec2((markOut + 0.5) / 256.0, 0.5));
  diffuseColor = mix(shown, mark.rgb, mark.a);
  ambientColor = vec3(0.0);
"""


def encode_values(values: AnyArray) -> AnyArray:
    """Values as float32 for the card; NaN and infinity become `NO_VALUE`."""
    coded = np.asarray(values).astype(np.float32)
    coded[~np.isfinite(coded)] = NO_VALUE
    return coded


def connect_attributes(mapper: vtkOpenGLPolyDataMapper) -> None:
    """Send the value and the mark of each point to the shader."""
    for name in (VALUE, MARK):
        mapper.MapDataArrayToVertexAttribute(name, name, vtkDataObject.FIELD_ASSOCIATION_POINTS, -1)


class Shading:
    """Property and shader that all blocks of a cloud share."""

    def __init__(self) -> None:
        self.property = vtkProperty()
        self.property.SetRepresentationToPoints()
        self.property.LightingOff()
        self.shader: vtkShaderProperty = vtkOpenGLShaderProperty()
        for text, first in ((VERTEX_DEC, "Dec"), (VERTEX_IMPL, "Impl")):
            self.shader.AddVertexShaderReplacement(f"//VTK::ValuePass::{first}", True, text, False)
        self.shader.AddFragmentShaderReplacement("//VTK::ValuePass::Dec", True, FRAGMENT_DEC, False)
        self.shader.AddFragmentShaderReplacement("//VTK::Color::Impl", True, FRAGMENT_COLOUR, False)
        self._palette, self._marks = _TableTexture(), _TableTexture()
        self.property.SetTexture("palette", self._palette.texture)
        self.property.SetTexture("marks", self._marks.texture)
        self.set_range(0.0, 1.0, False)
        self.set_missing((128, 128, 128), (128, 128, 128), 0.0)
        self.set_depths(-1.0, 1.0)

    def set_range(self, low: float, high: float, categorical: bool) -> None:
        """Set the limits of the colour table."""
        uniforms = self.shader.GetFragmentCustomUniforms()
        uniforms.SetUniformf("low", low)
        uniforms.SetUniformf("high", high)
        uniforms.SetUniformf("categorical", float(categorical))

    def set_palette(self, table: Bytes) -> None:
        """Set the colour table, (256, 4) uint8."""
        self._palette.fill(table)

    def set_marks(self, table: Bytes) -> None:
        """Set the colours of the marks, (256, 4) uint8."""
        self._marks.fill(table)

    def set_missing(self, colour: Rgb, haze: Rgb, strength: float) -> None:
        """Set the colour of points without a value, and how it fades with depth."""
        uniforms = self.shader.GetFragmentCustomUniforms()
        uniforms.SetUniform3f("missing", [part / 255.0 for part in colour])
        uniforms.SetUniform3f("haze", [part / 255.0 for part in haze])
        uniforms.SetUniformf("hazeStrength", strength)

    def set_depths(self, nearest: float, farthest: float) -> None:
        """Set the depths between which the haze grows; a negative one is orthographic."""
        uniforms = self.shader.GetVertexCustomUniforms()
        uniforms.SetUniformf("nearest", nearest)
        uniforms.SetUniformf("farthest", farthest)

    def set_point_size(self, pixels: float) -> None:
        """Set the side of a point in device pixels."""
        self.property.SetPointSize(pixels)


class _TableTexture:
    def __init__(self) -> None:
        self._image = vtkImageData()
        self._image.SetDimensions(256, 1, 1)
        self.fill(np.zeros((256, 4), np.uint8))
        self.texture = vtkTexture()
        self.texture.SetInputData(self._image)
        self.texture.SetColorModeToDirectScalars()
        self.texture.InterpolateOff()
        self.texture.RepeatOff()
        self.texture.EdgeClampOn()

    def fill(self, table: Bytes) -> None:
        scalars = numpy_to_vtk(np.ascontiguousarray(table), deep=1)
        self._image.GetPointData().SetScalars(scalars)
        self._image.Modified()
