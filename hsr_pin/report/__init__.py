"""Building blocks of the HTML reports: template environment, style sheet and inline figures.

- ``inline_svg``: matplotlib figures as SVG elements
- ``page``: the jinja environment of the report templates
"""
