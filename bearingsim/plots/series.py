"""Series and spectra of chosen jobs."""
