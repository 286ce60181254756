"""The shipped recipes, one TOML file each; `rotorwise dataset recipes` lists them."""
