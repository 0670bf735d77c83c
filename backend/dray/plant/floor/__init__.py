"""The floor in figures: points and polygons, rectangles that vehicles cover, lanes that bend, cells, how long a way takes."""
