"""Tables as laboratories have them, turned into the two files of the format of measured data."""
