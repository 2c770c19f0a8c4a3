"""What a page is made of beside the equations."""
