"""What is wrong: `alert_rules` says it whenever somebody looks, `alerts` keeps since when and who has taken it on."""
