// How people, cameras and shoots are named and coloured, the same everywhere.

export const numberOf = (tag) => Number(tag.slice(1));

export const shootName = (shoot, number) => shoot?.name || `shoot ${number}`;

/** "P2" or "P2 Anna". */
export const called = (tag, names) => (names[tag] ? `${tag} ${names[tag]}` : tag);

const UNNAMED = { fill: "#ffb000", ink: "#000000" };

export const colourOf = (tag, colours) => (tag === null ? UNNAMED : colours[numberOf(tag) % colours.length]);

export const PART_KEYS = { Eyes: "E", Shoulder: "S", Torso: "T", Head: "H" };

export const PART_WORDS = { Eyes: "the middle of the eyes", Shoulder: "the middle of the shoulders", Torso: "the middle of the torso", Head: "the middle of the head" };
