"""How large a fault is: estimates with intervals, and the severity zones that they lead to."""
