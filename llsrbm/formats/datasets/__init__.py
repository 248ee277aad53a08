"""Data sets: many motions in one folder, in any format of one motion or in one of their own.

`base` says what such a format is, `registry` which there are; a new one is one module and one line
there.
"""
