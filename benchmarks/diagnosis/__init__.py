"""Operating table of `bearingsim analyze`: detection, false alarms and named races on simulated signals."""
