"""What people do with model and observers, room by room; the Dataset is the wall between computing and showing."""
