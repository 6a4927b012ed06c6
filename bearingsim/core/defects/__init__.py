"""Defects: their shape, the path of a roller over them, and where its force jumps."""
