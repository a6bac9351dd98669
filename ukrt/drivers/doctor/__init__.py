"""What a machine allows and how it behaves: facts, measurements, advice."""
