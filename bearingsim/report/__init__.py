"""One page of results: an HTML file that needs no network."""
