"""From a problem file to a `Problem`: `load` reads the parts of the document, `lower` makes the graph."""
