"""What `equistream fit` does: see ../fit.py."""
