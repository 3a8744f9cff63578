/* Finished pieces of a long step, on disk as they come, so that a step that was stopped or killed goes on
 * where it was. A private file of one machine and one version of the program; anything unexpected in it is
 * not used. */
#ifndef AIRLIGHT_JOURNAL_H
#define AIRLIGHT_JOURNAL_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "airlight/status.h"

typedef struct al_journal al_journal;

/* Opens or begins the journal of the work `key`: pieces[count][size] as stored, and done[count], get what an
 * earlier run of the same work left. Both must live until al_journal_close. */
al_status al_journal_open(const char *path, uint64_t key, void *pieces, size_t size, bool *done,
                          uint32_t count, al_journal **journal, al_error *error);
/* Adds piece `index` as it is in memory and sets done. Any thread. AL_IO is kept and answered by the close.
 */
bool al_journal_append(al_journal *journal, uint32_t index);
/* Closes; the file stays. Answers what went wrong while writing. NULL is allowed. */
al_status al_journal_close(al_journal *journal, al_error *error);

#endif
