"""What pages are made of: their surroundings, their style, and pictures inside them.

- ``inline_svg``: pictures inside a page
- ``page``: in what surroundings pages are written
"""
