# The grid of gain, coupling, damping, lag and hand (docs/haptics.md, "The grid"); make test does a spread of it.
.PHONY: hil-passivity
hil-passivity: packages-build packages-test ## every combination of gain, coupling, stated damping and lag at an end wall: none is fast, none shakes
	@$(QUIET_MAKE) $(HIL_CAMPAIGN)
	@$(HIL_CAMPAIGN) --passivity 1 --tsv out/hil_passivity.tsv
