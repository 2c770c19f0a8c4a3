"""What a target's files say beside names, numbers and CasADi's code."""
