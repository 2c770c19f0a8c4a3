"""What a laboratory hands over: recordings and muscles, read strictly, in SI."""
