"""From the journal to observations, requests and solved sensors."""
