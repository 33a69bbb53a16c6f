"""Jobs over many states: their parts, their identity, and their files in Parquet."""
