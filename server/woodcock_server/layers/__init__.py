"""What a picture is made of, pixel by pixel, for those who look at it."""
