"""The blind check: recordings from plants that share nothing with the model, whose effect is withheld."""
