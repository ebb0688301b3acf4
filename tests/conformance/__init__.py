"""Files that are right, of known area, volume and box, in the formats in which nobody scans."""
