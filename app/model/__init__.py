"""The document: scans, leaves, operations and what is derived from them."""
