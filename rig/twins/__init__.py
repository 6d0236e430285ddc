"""The physical world, and one twin a device family with the codec of its driver."""
