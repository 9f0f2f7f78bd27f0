"""Equations solved for an unknown, by sines and cosines or polynomials; loops; branches; zero tests."""
