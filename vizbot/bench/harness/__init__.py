"""What every benchmark shares: kept results, keys, tables, workers."""
