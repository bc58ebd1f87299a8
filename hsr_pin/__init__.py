"""Simulate hybrid soft robots on Pinocchio, and find out which physics the model lacks."""
