"""Devices by hand: jog, devices, prove, simulate, service."""
