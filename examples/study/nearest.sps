* Nearest other person by size of the shot. CD to the folder of people.sav first.
GET FILE='people.sav'.
EXAMINE VARIABLES=nearest_m BY shot_size /PLOT=BOXPLOT /STATISTICS=DESCRIPTIVES /MISSING=LISTWISE.
MEANS TABLES=nearest_m BY shot_size /CELLS=COUNT MEAN STDDEV.
