"""What charts and tables share of the study's results."""
