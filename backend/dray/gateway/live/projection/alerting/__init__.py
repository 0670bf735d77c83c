"""What is wrong: `alert_rules` finds it at each look, `alerts` keeps since when and who has taken it on."""
