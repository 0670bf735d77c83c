"""The negotiation: announcement, bids, award, answers, and whose offers are believed (paper, 4.1). Knows no vehicle."""
