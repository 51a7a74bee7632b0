# The safety file (tools/safety): docs/safety_code.md.
##@ For assessors of safety
.PHONY: eva
eva: packages-safety ## analyse the safety code with Frama-C EVA; an unexplained alarm fails (docs/safety_code.md)
	@tools/safety/eva.py
