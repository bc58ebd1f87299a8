"""Blind check of the diagnosis on recordings from independent simulators, whose effect is withheld until the score."""
