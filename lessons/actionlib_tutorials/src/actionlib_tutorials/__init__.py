"""Servers and clients of the actions Fibonacci and Averaging."""
