/* This object is linked to the test programs that `make mutants` runs (docs/mutants.md). It lets a CMocka
 * program run a single one of its tests: the one that the variable MUTANT_TEST names. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <cmocka.h>

__attribute__((constructor)) static void run_one_test(void)
{
    cmocka_set_test_filter(getenv("MUTANT_TEST"));
}
