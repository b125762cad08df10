"""One job's picture held against another's: numbers, maps, and whether they differ by more than noise."""
