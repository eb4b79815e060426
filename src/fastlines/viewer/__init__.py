"""The viewer: a page in the browser that shows a tree, its lines, and the way of a ray through it.

Data flows from arrays to the page. `strokes`, `line_colors`, `node_boxes`, `node_path` and `shot` compute what is to be
seen, without a browser. `stage` draws it by viser, `panel` has the controls, and `viewer` holds both together.
"""
