"""Design functions, one module per method: plant and wishes in, Observer out."""
