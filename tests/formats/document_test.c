/* docs/formats.md lists exactly the rules of the code, number and text, and its hex dump is the golden file.
 */
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

/* Rows of all rule tables. */
static int listed_count(const char *document)
{
    static const char head[] = "\n| rule | a valid file keeps |\n| --- | --- |\n";
    int count = 0;
    for (const char *table = document; (table = strstr(table, head));)
        for (table += strlen(head); *table == '|'; table = strchr(table, '\n') + 1) count++;
    return count;
}

/* Rows "oooooo  hh hh ...  words" of the only code block, against the file. Dots promise the same byte up to
 * the next row, so that the rows account for the whole file. */
static void check_dump(const char *document, forged golden)
{
    const char *row = strstr(document, "\n```\n"), *end = row ? strstr(row + 5, "\n```\n") : NULL;
    size_t next = 0, rows = 0;
    uint8_t last = 0;
    CHECK(row && end);
    if (!row || !end) return;
    for (row += 5; row < end; row = strchr(row, '\n') + 1, rows++) {
        char *at;
        size_t offset = strtoul(row, &at, 16);
        CHECK(offset >= next && offset < golden.size);
        for (; next < offset && next < golden.size; next++) CHECK(golden.data[next] == last);
        while (at[0] == ' ' && (at == row + 6 || at[1] != ' ')) {
            uint8_t byte = (uint8_t)strtoul(at, &at, 16);
            CHECK(next < golden.size && golden.data[next] == byte);
            last = byte;
            next++;
        }
    }
    CHECK(rows > 30 && next == golden.size);
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
    forged golden = forge_load(AIRLIGHT_GOLDEN "/translucent_float_1_0.air");
    CHECK(golden.data != NULL);
    if (golden.data) check_dump((const char *)f.data, golden);
    free(golden.data);
    free(f.data);
    return test_end();
}
