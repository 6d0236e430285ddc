"""Byte streams over serial, TCP, memory, Prologix, VISA and Modbus; one question, one answer; no meaning."""
