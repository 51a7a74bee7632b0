# The safety file (tools/safety): docs/safety_code.md.
##@ For assessors of safety
.PHONY: eva misra
eva: packages-safety ## analyse the safety code with Frama-C EVA; an unexplained alarm fails (docs/safety_code.md)
	@tools/safety/eva.py

misra: packages-safety ## count deviations from MISRA C by rule; a risen count or a new rule fails (docs/safety_code.md)
	@tools/safety/misra.py --jobs $(JOBS)
