"""Learning from simulated machines: tables of features, classifiers, their cards and files, their judgement."""
