"""Files beside a journal, or elsewhere where its folder takes none: what it cannot take, who runs it, the verdict."""
