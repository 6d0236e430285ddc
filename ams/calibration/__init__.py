"""The whole story of a calibration: observations and a request go in, a result and its document come out."""
