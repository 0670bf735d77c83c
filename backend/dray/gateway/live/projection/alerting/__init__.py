"""What is wrong: `alert_rules` says it whenever somebody looks, `alerts` keeps since when and who has taken it on.

`silence` judges whether an agent is lost as the agents themselves judge it.
"""
