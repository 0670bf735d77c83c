"""The negotiation: announcement, bids, award, answers, and trust in bidders (paper, 4.1). Knows no vehicle."""
