"""Lines as objects of other packages."""
