/* docs/formats.md lists exactly the rules of the code, number and text. */
#include "rules.h"

#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "../test.h"
#include "forge.h"

#define ROW(name, number, text) {number, text},
static const struct {
    int number;
    const char *text;
} rules[] = {AL_RULES(ROW)};

enum { RULE_COUNT = sizeof rules / sizeof *rules };

static bool is_listed(const char *document, int number, const char *text)
{
    char row[512];
    snprintf(row, sizeof row, "\n| %d | %s |\n", number, text);
    return strstr(document, row) != NULL;
}

/* Rows of the documents' rule tables: "| 1xx | ". */
static int listed_count(const char *document)
{
    int count = 0;
    for (const char *at = document; (at = strstr(at, "\n| ")); at++)
        count += at[3] >= '1' && at[3] <= '9' && at[4] >= '0' && at[4] <= '9' && at[5] >= '0' && at[5] <= '9' && at[6] == ' ';
    return count;
}

int main(void)
{
    forged f = forge_load(AIRLIGHT_DOCS "/formats.md");
    CHECK(f.data != NULL);
    if (!f.data) return test_end();
    f.data[f.size] = 0;
    for (int i = 0; i < RULE_COUNT; i++) {
        for (int k = 0; k < i; k++) CHECK(rules[i].number > rules[k].number);
        bool listed = is_listed((const char *)f.data, rules[i].number, rules[i].text);
        if (!listed) fprintf(stderr, "docs/formats.md lacks: | %d | %s |\n", rules[i].number, rules[i].text);
        CHECK(listed);
    }
    CHECK(listed_count((const char *)f.data) == RULE_COUNT);
    free(f.data);
    return test_end();
}
