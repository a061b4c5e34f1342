"""What naming the cause is worth: errors on readings that were not used."""
