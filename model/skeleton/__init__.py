"""What the muscles pull: a tree of links and joints, and the pair's load, which is the smallest one."""
