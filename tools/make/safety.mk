# The safety file (tools/safety): docs/safety.md, docs/safety_code.md.
##@ For assessors of safety
.PHONY: trace eva misra
trace: ## check that each safety requirement has code, tests and a hazard, and write the tables of docs/safety.md
	@tools/safety/trace_safety.py --write

eva: packages-safety ## analyse the safety code with Frama-C EVA; an unexplained alarm fails (docs/safety_code.md)
	@tools/safety/eva.py

misra: packages-safety ## count deviations from MISRA C by rule; a risen count or a new rule fails (docs/safety_code.md)
	@tools/safety/misra.py --jobs $(JOBS)
