"""What devices can do, whoever made them, and what drivers of several makers share: waiting, rest, limits, talk."""
