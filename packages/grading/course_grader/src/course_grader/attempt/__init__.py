"""One run of one program: simulator, stimuli, recording."""
